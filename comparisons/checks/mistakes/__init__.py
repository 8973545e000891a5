"""The catalogue of likely mistakes: each is tried on what it predicts.

Of what is told (`observables`), of how it moves (`motions`), of what a reader of a file adds, loses
or takes for another frame (`terms`), and of shares of the parts of a model (`shares`).
"""
