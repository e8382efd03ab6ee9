"""Trials: evaluations of a policy against baselines, and certificates of them.

`arms` plays a policy, the expert, random actions, holding still and stalling from the same seeds.
`results` computes the metrics. `certificate` writes them to a file, which `verification` plays
again and compares bit for bit.
"""
