"""Build the Airy table and store it in the cache; says how long it took.

python tools/build_airy_table.py
"""

from __future__ import annotations

from rtbow.tables.report import describe_build

if __name__ == "__main__":
    print(describe_build())
