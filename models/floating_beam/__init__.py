"""The hub afloat with a chain of rods as MJCF and as Exudyn models."""
