"""The air's own light: what molecules scatter more than once, over height and sun."""
