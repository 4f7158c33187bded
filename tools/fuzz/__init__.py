"""Random inputs to rtbow: scenes of extremes, damaged scene texts, damaged volume files.

    python tools/fuzz scenes|texts|volumes [--seconds N] [-o FOLDER]

Each must end in a finite frame or volume, or in an error that says what is wrong with the input,
within a time and a memory. Inputs that end otherwise are kept in FOLDER, under their seed.
"""
