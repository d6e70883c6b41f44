"""Page on a study: HTML without external parts, made from frames and datasets."""
