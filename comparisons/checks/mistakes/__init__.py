"""The catalogue of likely mistakes, each of which is compared by its prediction.

They are mistakes in returned observables (`observables`), in motions (`motions`), and in the parts
of a model, with terms and frames that a reader of a file adds, drops or confuses (`parts`).
"""
