"""Tests import their naive twins and the checks of documents from this folder."""
