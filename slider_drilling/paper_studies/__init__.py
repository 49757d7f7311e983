"""The paper's vibration tools as motions of one contact, and the studies that check the paper's claims with them.

`pipe` and `tool_motions` define what is moved and how, `settled_cycle` the friction to which a motion settles. Each
study is one module, listed in `catalogue`; it compares claims of the paper with the model.
"""
