"""The paper's vibration tools as motions of one contact, and its studies.

`pipe` and `motions` say what is moved and how, `steady` finds the friction that a motion settles to, and each
study (one module each, listed in `catalogue`) holds what the paper says against what the model does.
"""
