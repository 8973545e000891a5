"""Engines: the protocol, the guard around a run, the registry, adapters."""
