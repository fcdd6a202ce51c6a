"""All formats that are more than a table, in the order in which they are tried."""

from __future__ import annotations

from . import ais, asterix, geojson, geolife, gpx, igc, kml, mot, nmea, opensky, readsb, sbs, tcx
from .records import Format

FORMATS: tuple[Format, ...] = (
    asterix.FORMAT,
    gpx.FORMAT,
    kml.FORMAT,
    tcx.FORMAT,
    readsb.TRACES,
    readsb.SNAPSHOTS,
    opensky.FORMAT,
    geojson.FORMAT,
    sbs.FORMAT,
    nmea.FORMAT,
    ais.FORMAT,
    geolife.FORMAT,
    igc.FORMAT,
    mot.FORMAT,
)
