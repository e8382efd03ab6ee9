"""How far an episode has come by the expert's stages, without playing the expert."""
