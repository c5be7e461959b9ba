"""What the fixed-camera methods share: deep frame-buffer, gather cloud, hierarchy, links."""
