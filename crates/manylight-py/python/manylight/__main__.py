"""``python -m manylight`` is the command ``manylight``."""

from ._command import main

main()
