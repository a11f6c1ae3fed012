"""Constants of nature that more than one component needs, each with its unit and source."""

# Standard acceleration of free fall [m/s^2], exact by definition: 3rd CGPM (1901), ISO 80000-3:2019.
GRAVITY = 9.80665

# Fresh water at 20 degC and 101.325 kPa [kg/m^3]: Tanaka et al. 2001, Metrologia 38, 301-309, Table 1.
FRESH_WATER_DENSITY = 998.2067

# Sea water of 15 degC and practical salinity 35 at the surface [kg/m^3]: EOS-80, UNESCO Tech. Pap. 44 (1983).
SEA_WATER_DENSITY = 1025.97
