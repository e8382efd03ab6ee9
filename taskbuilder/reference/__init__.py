"""The reference: every finding code, key, condition, verb and channel, in words.

The pages of the documentation are made from it, and `taskbuilder explain` prints it.
"""
