"""What a page in a browser shows of an answer, as data and as ES modules.

For the report and for the workbench.

A report has no server: all that is pointed at must be in its file. The workbench draws with the
same modules, and its server sends them without importing anything that computes: this package
itself imports nothing.
"""
