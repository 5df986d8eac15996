"""Figures fit to print: tables in, a matplotlib Figure out, nothing computed but the layout.

One function per figure; `style` holds what they share, `style.save` writes them.
"""
