"""Local lights, environments and skies: one contract (`base`), one file per light, one table."""
