"""The catalogue of likely mistakes: each is compared by its prediction.

Mistakes in returned observables (`observables`), in motions (`motions`), in terms and frames that a
reader of a file adds, drops or confuses (`terms`), and in shares of the parts of a model
(`shares`).
"""
