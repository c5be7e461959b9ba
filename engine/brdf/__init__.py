"""BRDFs: one contract (`base`), one file per model, one table.

Everything here takes local directions: z is the normal, both directions leave the surface, and
the value does not include the cosine.
"""
