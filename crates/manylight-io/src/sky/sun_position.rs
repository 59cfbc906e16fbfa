//! Direction to the sun from place and time.

use manylight::math::Vec3;

/// Location of an observer on the earth, and local time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaceAndTime {
    /// Latitude in degrees, positive to the north.
    pub latitude: f32,
    /// Longitude in degrees, positive to the east.
    pub longitude: f32,
    /// Local time minus universal time in hours.
    pub timezone: f32,
    /// Year.
    pub year: i32,
    /// Month, from 1.
    pub month: i32,
    /// Day of the month, from 1.
    pub day: i32,
    /// Hour of local time; fractions are allowed.
    pub hour: f32,
    /// Minute; fractions are allowed.
    pub minute: f32,
    /// Second; fractions are allowed.
    pub second: f32,
}

impl Default for PlaceAndTime {
    /// Mitsuba's default: Tokyo, 10 July 2010, 15:00.
    fn default() -> Self {
        let (latitude, longitude, timezone) = (35.6894, 139.6917, 9.0);
        PlaceAndTime {
            latitude,
            longitude,
            timezone,
            year: 2010,
            month: 7,
            day: 10,
            hour: 15.0,
            minute: 0.0,
            second: 0.0,
        }
    }
}

impl PlaceAndTime {
    /// Unit vector to the sun in the frame x south, y west, z up. Source: the PSA algorithm of
    /// Blanco-Muriel et al. 2001, with its parallax correction.
    pub fn sun_direction(&self) -> Vec3 {
        let hours = f64::from(self.hour - self.timezone)
            + (f64::from(self.minute) + f64::from(self.second) / 60.0) / 60.0;
        let days = self.days_since_2000(hours);

        // Ecliptic coordinates.
        let omega = 2.1429 - 0.001_039_459_4 * days;
        let mean_longitude = 4.895_063_0 + 0.017_202_791_698 * days;
        let anomaly = 6.240_060_0 + 0.017_201_969_9 * days;
        let longitude =
            mean_longitude + 0.033_416_07 * anomaly.sin() + 0.000_348_94 * (2.0 * anomaly).sin()
                - 0.000_113_4
                - 0.000_020_3 * omega.sin();
        let obliquity = 0.409_092_8 - 6.2140e-9 * days + 0.000_039_6 * omega.cos();

        // Celestial coordinates.
        let right_ascension = (obliquity.cos() * longitude.sin()).atan2(longitude.cos());
        let declination = (obliquity.sin() * longitude.sin()).asin();

        // Local coordinates.
        let sidereal_hours = 6.697_424_324_2 + 0.065_709_828_3 * days + hours;
        let hour_angle =
            (sidereal_hours * 15.0 + f64::from(self.longitude)).to_radians() - right_ascension;
        let latitude = f64::from(self.latitude).to_radians();
        let zenith = (latitude.cos() * hour_angle.cos() * declination.cos()
            + declination.sin() * latitude.sin())
        .clamp(-1.0, 1.0)
        .acos();
        let azimuth = (-hour_angle.sin())
            .atan2(declination.tan() * latitude.cos() - latitude.sin() * hour_angle.cos());
        const EARTH_RADIUS_PER_SUN_DISTANCE: f64 = 6371.01 / 149_597_890.0;
        let zenith = zenith + EARTH_RADIUS_PER_SUN_DISTANCE * zenith.sin();
        Vec3::new(
            (-azimuth.cos() * zenith.sin()) as f32,
            (-azimuth.sin() * zenith.sin()) as f32,
            zenith.cos() as f32,
        )
    }

    /// Days since 1 January 2000, 12:00 universal time. `hours` is the universal time of day in
    /// hours.
    fn days_since_2000(&self, hours: f64) -> f64 {
        // Julian day number by Fliegel and van Flandern 1968; the integer divisions truncate on
        // purpose.
        let january = (self.month - 14) / 12;
        let julian_day = (1461 * (self.year + 4800 + january)) / 4
            + (367 * (self.month - 2 - 12 * january)) / 12
            - (3 * ((self.year + 4900 + january) / 100)) / 4
            + self.day
            - 32075;
        f64::from(julian_day) - 0.5 + hours / 24.0 - 2_451_545.0
    }
}
