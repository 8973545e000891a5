"""hula_hoop as MJCF and as Exudyn models."""
