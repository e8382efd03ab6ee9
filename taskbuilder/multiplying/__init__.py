"""New demonstrations from few: cut where things are taken and reached, and moved with them."""

from __future__ import annotations
