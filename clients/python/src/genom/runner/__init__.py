"""Runs codels in Python: ``python -m genom.runner`` is a cell of genomd.

genomd starts it for a component with ``lang "python"``. The process loads genomd as a library
(`_runtime`), which calls `_loader` for each script: its text is run (`_script`), its functions are
compared with the description (`_check`), and C functions are made of them (`_codel`). Codels work
on the memory of the component (`_kinds`, `_numbers`, `_lists`, `_records`) and on ports (`_ports`).
"""
