"""A boundary that is quickly followed."""

SMALL = "boundary hula_hoop --x force_frequency=5.6:6 --y force_amplitude=15:24 --lines 2"
"""A corner of figure 4, which one curve crosses."""
