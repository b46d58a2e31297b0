"""Anchors of headings, as the pages' links name them (and as code hosts make them)."""
import re


def slugify(title, separator="-"):
    plain = re.sub(r"<[^>]*>", "", title)
    return re.sub(r"[^\w\- ]", "", plain.strip().lower()).replace(" ", separator)
