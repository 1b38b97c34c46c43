"""Loops that numpy has no words for: modules that Cython compiles at installation, and that run uncompiled as well.

Each is plain Python with the types of C written beside it (Cython's pure Python mode), so there is one text, the same
results, and no compiler needed, only many times as long. They take arrays that their callers have checked.
"""

from __future__ import annotations

__all__: list[str] = []
