"""What scripts/study runs: one module a study, over one runner of the program (program.py) and one writer of pages (page.py)."""
