using System;

namespace OpenRoIS.Link
{
    /// <summary>
    /// Between the link (seen from above: x right, y away from the viewer, th counter-clockwise from x, in radians) and
    /// Unity (x right, y up, z ahead, yaw clockwise from z, in degrees).
    /// </summary>
    public static class Coordinates
    {
        private const double Degrees = 180.0 / Math.PI;

        /// <summary>Unity's x and z of a place of the link, for a floor at Unity's origin.</summary>
        public static void ToUnity(double x, double y, out double unityX, out double unityZ)
        {
            unityX = x;
            unityZ = y;
        }

        /// <summary>The place on the link of Unity's x and z.</summary>
        public static FloorPoint ToLink(double unityX, double unityZ)
        {
            return new FloorPoint(unityX, unityZ);
        }

        /// <summary>Yaw in degrees, from 0 to less than 360, of a direction in radians.</summary>
        public static double ToYaw(double th)
        {
            double yaw = (90.0 - th * Degrees) % 360.0;
            yaw = yaw < 0 ? yaw + 360.0 : yaw;
            return yaw >= 360.0 ? 0.0 : yaw;
        }

        /// <summary>Direction in radians, from -pi to pi, of a yaw in degrees.</summary>
        public static double ToTh(double yaw)
        {
            return Wrapped((90.0 - yaw) / Degrees);
        }

        /// <summary>The same angle between -pi and pi.</summary>
        public static double Wrapped(double th)
        {
            return Math.IEEERemainder(th, 2 * Math.PI);
        }
    }
}
