"""Trials: what a player achieves to the end of its episodes, beside others, and a proof of it.

`arms` plays a policy, the expert, random play, holding still and stalling from the same seeds;
`results` says what they achieved; `certificate` writes that to a file that `verification` plays
again and compares to the bit.
"""
