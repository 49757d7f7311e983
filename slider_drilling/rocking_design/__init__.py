"""How to rock: amplitude, period and offset for each depth, and what they free and carry to the bit.

`closed_forms` gives the bit's load, the offset and the first amplitude; `steady_rocking` runs the plant in steady
rocking; `plan` chooses the amplitude for each depth; `page`, `sheet` and `controller_settings` write the result.
"""
