"""The driven body on a ball joint as MJCF and as Exudyn models."""
