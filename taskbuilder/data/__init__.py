"""Data sets of episodes: collecting, reading, checking and exporting them.

    dataset = taskbuilder.load_dataset("data/handover")
    for episode in dataset:
        print(episode.instruction, episode.actions["left"].shape)

Reading a data set executes nothing that comes with it: it consists of JSON, arrays and videos.
"""
