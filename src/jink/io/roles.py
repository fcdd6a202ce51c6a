"""Names of columns in the ADS-B, AIS, radar and GPS world, and what they are taken for.

`ROLES` holds what is measured, `MARKS` what is said about it (which half of the globe, how old, how accurate,
whether it is to be believed), `RATES` velocities. The preferred name of a role comes first.
"""

from __future__ import annotations

from collections.abc import Mapping

from .units import ANGLE, DEGREE, FOOT, FOOT_PER_MINUTE, KNOT, LENGTH, SPEED, TIME

Named = dict[str, tuple[Mapping[str, float], tuple[str, ...]]]

ALTITUDES = (
    *("altitude", "geoaltitude", "geo_altitude", "geom_altitude", "alt_geom", "baroaltitude", "baro_altitude"),
    *("alt_baro", "alt", "flight_level", "flightlevel", "fl", "height", "elevation_above_sea", "ele"),
    *("height_above_msl", "altitude_msl", "alt_msl", "height_above_mean_sea_level", "height_msl", "amsl"),
    *("height_above_ellipsoid", "altitude_ellipsoid", "alt_ellipsoid", "gps_altitude", "gps_alt", "altg"),
    *("galt", "enhanced_altitude"),
)
ROLES: Named = {
    "target": (
        {},
        (
            *("target", "target_id", "track_id", "tracknumber", "track_number", "trajectory_id", "flight_id"),
            *("icao24", "icao", "hex", "hexident", "hex_ident", "mmsi", "callsign", "ident", "flight", "vessel_id"),
            *("vehicle_id", "aircraft_id", "object_id", "device_id", "trip_id", "tail", "registration", "imo"),
            *("individual_local_identifier", "tag_local_identifier", "individual_id", "animal_id", "tag_id"),
            *("user_id", "person_id", "agent_id", "pedestrian_id", "taxi_id", "ship_id", "imei", "id", "name"),
        ),
    ),
    "time": (
        TIME,
        (
            *("time", "timestamp", "t", "datetime", "date_time", "basedatetime", "base_date_time", "time_position"),
            *("timeposition", "epoch", "unixtime", "unix_time", "utc", "ts", "time_utc", "timestamp_utc", "gps_time"),
            *("received_at", "rxtime", "rx_time", "tagblock_timestamp", "time_stamp", "utc_time", "time_gps"),
            *("time_local", "local_time", "event_time", "date_time_utc", "datetime_utc", "utc_datetime", "time_usec"),
            *(
                "time_utc_usec",
                "timeus",
                "updatetime",
                "update_time",
                "date",
                "last_update",
                "lastposupdate",
                "now",
                "posix_time",
                "unix_epoch",
            ),
            *(
                "gms",
                "tow",
                "gps_tow",
                "itow",
                "time_of_week",
                "gps_seconds",
                "gps_second",
                "seconds_of_week",
                "gps_sow",
            ),
            *("sow", "study_local_timestamp", "dt_pos_utc", "elapsed", "elapsed_time", "time_elapsed", "uhrzeit"),
            *("recorded_at", "created_at", "fix_time", "gpstime", "when", "zeit", "heure", "hora", "tst"),
            *("timestamp_external", "timestampexternal", "pos_time", "postime", "stamp", "header_stamp", "stamp_sec"),
            *("stamp_secs", "secs", "sec"),
        ),
    ),
    "latitude": (
        ANGLE,
        (
            *("latitude", "lat", "position_latitude", "location_lat", "gps_lat", "gps_latitude", "position_lat"),
            *("latitud", "breitengrad", "breite"),
        ),
    ),
    "longitude": (
        ANGLE,
        (
            *("longitude", "lon", "lng", "long", "position_longitude", "location_long"),
            *("gps_lon", "gps_long", "gps_longitude", "location_lng", "location_lon", "position_long", "position_lon"),
            *("longitud", "langengrad", "laengengrad", "lange", "laenge"),
        ),
    ),
    "altitude": (LENGTH, (*ALTITUDES, "elevation", "elev")),
    "x": (LENGTH, ("x", "px", "pos_x", "position_x", "easting", "east", "measured_x", "utm_easting", "utm_x")),
    "y": (LENGTH, ("y", "py", "pos_y", "position_y", "northing", "north", "measured_y", "utm_northing", "utm_y")),
    "z": (LENGTH, ("z", "pz", "pos_z", "position_z", "up", "measured_z", *ALTITUDES, "down")),
    "range": (LENGTH, ("range", "slant_range", "rho", "distance", "r")),
    "azimuth": (ANGLE, ("azimuth", "az", "theta", "bearing")),
    "elevation": (ANGLE, ("elevation", "el", "elev", "elevation_angle")),
    "speed": (SPEED, ("speed", "groundspeed", "ground_speed", "gs", "sog", "speed_over_ground", "velocity")),
    "course": (
        ANGLE,
        (
            *("course", "track", "cog", "course_over_ground", "true_track", "track_angle", "direction", "trak"),
            *("heading", "bearing"),
        ),
    ),
    "velocity_x": (
        SPEED,
        (
            *("velocity_x", "vx", "vel_x", "v_x", "velocity_east", "vel_east", "vel_e", "v_east", "ve"),
            *("east_velocity", "eastward_velocity", "speed_east"),
        ),
    ),
    "velocity_y": (
        SPEED,
        (
            *("velocity_y", "vy", "vel_y", "v_y", "velocity_north", "vel_north", "vel_n", "v_north", "vn"),
            *("north_velocity", "northward_velocity", "speed_north"),
        ),
    ),
    "vertical_rate": (
        SPEED,
        (
            *("vertical_rate", "vertrate", "vert_rate", "geom_rate", "baro_rate", "climb_rate", "rate_of_climb"),
            *("vertical_speed", "vert_speed", "vspeed", "velocity_z", "vz", "vel_z", "v_z", "velocity_up", "vel_up"),
            *("vel_d", "velocity_down", "vel_down", "v_down", "vd", "vsi"),
        ),
    ),
    "range_rate": (
        SPEED,
        (
            *("range_rate", "rangerate", "radial_velocity", "radial_speed", "doppler_velocity", "doppler", "rdot"),
            *("r_dot", "vr"),
        ),
    ),
    "nacp": ({}, ("nacp", "nac_p", "nac")),
    "nic": ({}, ("nic",)),
    "gva": ({}, ("gva",)),
    "nacv": ({}, ("nacv", "nac_v")),
    "velocity_accuracy": (
        SPEED,
        (
            *("velocity_accuracy", "speed_accuracy", "velocity_sd", "speed_sd", "sacc", "s_acc", "s_variance"),
            *("vel_accuracy", "velocity_accuracy_horizontal"),
        ),
    ),
    "vertical_rate_accuracy": (
        SPEED,
        ("vertical_rate_accuracy", "vertical_speed_accuracy", "vertical_rate_sd", "vertical_speed_sd"),
    ),
    "source": ({}, ("source", "sensor", "sensor_id", "radar", "radar_id", "station", "sac_sic")),
    # what is said about a measurement
    "place": (
        {},
        (
            *("place", "position", "gps", "location", "coordinates", "coordinate", "coords", "latlon", "lat_lon"),
            *("latlng", "lat_lng", "lat_long", "latlong", "lonlat", "lon_lat", "lnglat", "gps_position"),
            *(
                "gps_coordinates",
                "latitude_longitude",
                "longitude_latitude",
                "point",
                "geom",
                "geometry",
                "the_geom",
                "geog",
                "wkt",
            ),
        ),
    ),
    "date": ({}, ("date", "utc_date", "date_utc", "gps_date", "local_date", "day", "datum", "fecha")),
    "year": ({}, ("year", "yyyy", "yr", "jahr", "annee", "ano")),
    "month": ({}, ("month", "mm", "mon", "mo", "monat", "mois", "mes")),
    "day": ({}, ("day", "dd", "day_of_month", "dy", "tag", "jour", "dia")),
    "hour": ({}, ("hour", "hh", "hr", "hours", "stunde", "heure")),
    "minute": ({}, ("minute", "mi", "min", "mn", "minutes")),
    "second": ({}, ("second", "ss", "sec", "secs", "seconds", "sekunde")),
    "nanosecond": (
        {},
        ("nsecs", "nsec", "nanosec", "nanosecs", "nanoseconds", "nanosecond", "stamp_nsec", "stamp_nsecs"),
    ),
    "week": ({}, ("gps_week", "gpsweek", "gwk", "week", "gps_week_number", "week_number", "wn")),
    "north_south": (
        {},
        (
            *("n_s", "ns", "north_south", "lat_ns", "latitude_ns", "latitude_n_s", "lat_n_s", "lat_ref"),
            *("latitude_ref", "lat_dir", "lat_direction", "latitude_direction", "lat_hemisphere", "lat_hemi"),
            *("latitude_hemisphere", "ns_indicator", "n_s_indicator", "gps_latitude_ref", "lath", "latitude_dir"),
        ),
    ),
    "east_west": (
        {},
        (
            *("e_w", "ew", "east_west", "lon_ew", "longitude_ew", "longitude_e_w", "lon_e_w", "lon_ref"),
            *("longitude_ref", "lon_dir", "lon_direction", "longitude_direction", "lon_hemisphere", "lon_hemi"),
            *("longitude_hemisphere", "ew_indicator", "e_w_indicator", "gps_longitude_ref", "lonh", "longitude_dir"),
        ),
    ),
    "latitude_minutes": ({}, ("lat_min", "lat_minutes", "lat_minute", "latitude_min", "latitude_minutes", "lat_mm")),
    "latitude_seconds": ({}, ("lat_sec", "lat_seconds", "lat_second", "latitude_sec", "latitude_seconds", "lat_ss")),
    "longitude_minutes": (
        {},
        ("lon_min", "lon_minutes", "lon_minute", "longitude_min", "longitude_minutes", "lon_mm", "long_min", "lng_min"),
    ),
    "longitude_seconds": (
        {},
        ("lon_sec", "lon_seconds", "lon_second", "longitude_sec", "longitude_seconds", "lon_ss", "long_sec", "lng_sec"),
    ),
    "position_time": (TIME, ("position_time", "lastposupdate", "last_pos_update", "time_position", "timeposition")),
    "age": (TIME, ("seen_pos", "position_age", "age_of_position", "pos_age")),
    "accuracy": (
        LENGTH,
        (
            *("accuracy", "horizontal_accuracy", "accuracy_horizontal", "h_accuracy", "hacc", "h_acc", "eph"),
            *("accuracy_h", "location_accuracy", "gps_accuracy", "position_sd", "est_horizontal_error"),
        ),
    ),
    "vertical_accuracy": (
        LENGTH,
        (
            *("vertical_accuracy", "accuracy_vertical", "v_accuracy", "vacc", "v_acc", "epv", "accuracy_v"),
            *("altitude_accuracy", "altitude_sd", "est_vertical_error"),
        ),
    ),
    "variance": (
        {},
        (
            *("position_covariance0", "position_covariance_0", "position_variance", "cov_xx", "covariance_xx"),
            *("var_x", "variance_x", "cov_x_x"),
        ),
    ),
    "hdop": ({}, ("hdop", "gps_hdop", "h_dop")),
    "on_ground": ({}, ("on_ground", "onground", "is_on_ground", "isonground", "alt_baro")),
    "station": ({}, ("type_of_mobile", "mobile_type")),
    "valid": (
        {},
        (
            *("valid", "visible", "is_valid", "position_valid", "pos_valid", "fix_valid", "gps_valid", "xy_valid"),
            *("fix_type", "fixtype", "gps_fix", "gps_fix_type", "fix_quality"),
        ),
    ),
    "outlier": (
        {},
        (
            *("outlier", "is_outlier", "manually_marked_outlier", "algorithm_marked_outlier"),
            "import_marked_outlier",
        ),
    ),
}
MARKS = {
    *("year", "month", "day", "hour", "minute", "second", "nanosecond"),
    *("latitude_minutes", "latitude_seconds", "longitude_minutes", "longitude_seconds"),
    *("place", "date", "week", "north_south", "east_west", "position_time", "age"),
    *("velocity_accuracy", "vertical_rate_accuracy", "nacv"),
    *("accuracy", "vertical_accuracy", "variance", "hdop", "on_ground", "station", "valid", "outlier"),
}
# what is said about motion: it is used if it helps to predict the positions (tracking/velocity.py)
RATES = ("speed", "course", "velocity_x", "velocity_y", "vertical_rate", "range_rate")

CUSTOMARY_UNIT = {
    "alt_baro": FOOT,
    "alt_geom": FOOT,
    "flight_level": 100 * FOOT,
    "flightlevel": 100 * FOOT,
    "fl": 100 * FOOT,
    "latitude": DEGREE,
    "longitude": DEGREE,
    "gs": KNOT,
    "sog": KNOT,
    "groundspeed": KNOT,
    "speed_over_ground": KNOT,
    "geoaltitude": 1.0,
    "geo_altitude": 1.0,
    "geom_altitude": 1.0,
    "baroaltitude": 1.0,
    "baro_altitude": 1.0,
    "timeus": 1e-6,
    "gms": 1e-3,
    "itow": 1e-3,
    "down": -1.0,
    "track": DEGREE,
    "cog": DEGREE,
    "course_over_ground": DEGREE,
    "true_track": DEGREE,
    "track_angle": DEGREE,
    "trak": DEGREE,
    "direction": DEGREE,
    "heading": DEGREE,
    "geom_rate": FOOT_PER_MINUTE,
    "baro_rate": FOOT_PER_MINUTE,
    "vel_d": -1.0,
    "velocity_down": -1.0,
    "vel_down": -1.0,
    "v_down": -1.0,
    "vd": -1.0,
}
POSITIONS = {"geographic": ("latitude", "longitude"), "cartesian": ("x", "y"), "polar": ("range", "azimuth")}
