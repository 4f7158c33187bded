"""Print every number of docs/sky.md, with the bound that a test holds it to.

    python tools/sky_error [PART]... [--list] [--fit [MODEL]] [--pixels 400] [--runs 15]

Without parts, all of them. What tests compare is computed by the same functions, which lie in
``tests/support/skies``. Solved skies are kept in the cache: the first run takes longest. Times are
this machine's, and held to nothing. The exit status is 1 where a bound is not met.
"""
