"""The rigid body as MJCF and as Exudyn models."""
