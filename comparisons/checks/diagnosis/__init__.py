"""Where a deviation comes from: known mistakes of engines, tried one by one on what they predict.

A mistake is named where it explains what an engine computes, to a small share of its error, alone
or to a small share of what the next one leaves. Else nothing is said but what was measured.
"""
