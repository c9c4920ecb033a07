"""What an arm looks like: triangles by joint, and pictures of them."""
