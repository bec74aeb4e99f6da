"""
Kinds of arrays that the whole planner shares.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]


Points = NDArray[np.float64]
