"""What all generators of robots share: meshes of solids, forms, and robots as URDF."""
