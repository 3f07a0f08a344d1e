"""Types of the arrays that the package hands on."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]          # of numbers, as they are stored
Reals = NDArray[np.float64]
