"""``mbcheck tradeoff MODEL.xml``: which step and which integrator a model needs."""
