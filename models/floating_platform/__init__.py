"""The floating platform with rotor and pendulum as MJCF and as Exudyn models."""
