"""All formats that are more than a table, in the order in which they are tried."""

from __future__ import annotations

from . import geojson, geolife, gpx, igc, kml, mot, nmea, opensky, readsb, sbs
from .records import Format

FORMATS: tuple[Format, ...] = (
    gpx.FORMAT,
    kml.FORMAT,
    readsb.TRACES,
    readsb.SNAPSHOTS,
    opensky.FORMAT,
    geojson.FORMAT,
    sbs.FORMAT,
    nmea.FORMAT,
    geolife.FORMAT,
    igc.FORMAT,
    mot.FORMAT,
)
