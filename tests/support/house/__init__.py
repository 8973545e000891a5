"""The rules of the house: what a module, a class, a function and a name may be.

``python -m mbcheck.tests.support.house [RULE]`` lists what breaks them.
"""
