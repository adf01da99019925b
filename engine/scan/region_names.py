"""The usual regions of a face and what belongs to them. Loads nothing, so that windows may show it early."""

from __future__ import annotations

OTHER = "other"
"""The region of faces that a template names no region for."""

MEANING = {
    "brows": "From root to tail, with the bone under the hair",
    "lids": "Upper lid up to the brow and lower lid",
    "eyes": "What shows between the lids",
    "nose": "From the root to the base, with the wings",
    "lips": "The red of both lips",
    "mouth": "The skin around the lips, from the nose to the fold of the chin",
    "cheeks": "From the lower lids to the jaw",
    "jaw": "Chin and jaw",
    "forehead": "Above the brows, with the temples",
    OTHER: "What the template gives to no region",
}
"""What belongs to each of the usual regions, in a few words."""
