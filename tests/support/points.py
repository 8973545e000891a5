"""Points of a batch: parameters of hula_hoop that are arrays."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbcheck.reference.hula_hoop.equations import PLATE, HulaHoop


def random_parameters(rng: np.random.Generator, count: int, factor: float = 1.4) -> Any:
    """Return defaults times log-uniform factors, as arrays (count,), half of them plates."""
    values: dict[str, Any] = {
        name: value * np.exp(rng.uniform(np.log(0.7), np.log(factor), count))
        for name, value in HulaHoop().as_dict().items()
    }
    values["inertia_ratio"] = np.where(np.arange(count) % 2, PLATE.inertia_ratio, 0.0)
    return HulaHoop(**values)


def point(parameters: HulaHoop, index: int) -> HulaHoop:
    """Return one point of parameters that are all arrays."""
    return HulaHoop(**{k: v[index] for k, v in parameters.as_dict().items()})
