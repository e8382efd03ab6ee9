"""Learning: the learners, their training, and the policies that came of it.

Only the modules that train need torch; policies play without.
"""
