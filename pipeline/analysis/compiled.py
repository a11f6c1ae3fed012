"""Compilation of the analysis' kernels, which run over whole batches of frames.

numba's cache sees an edit of the file a kernel stands in, not of the files its callees stand in: a kernel here
calls kernels of its own file only.
"""

from numba import njit

from components.compiled import OPTIONS

kernel = njit(cache=True, nogil=True, **OPTIONS)
