"""Causes of deviations: known mistakes of engines, each compared with what it would predict.

A mistake is named if it alone explains an engine's results to a small share of their error, or to a
small share of the error that the next best mistake leaves. Otherwise no cause is named.
"""
