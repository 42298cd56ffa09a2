"""Imports `leave_blank` in each Python process that has this folder on its path and is not isolated.

A distribution may have a module of this name, which isolated processes have imported before their program begins.
"""

import leave_blank  # noqa: F401  # of this folder
