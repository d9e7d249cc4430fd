using System;

namespace OpenRoIS.Link
{
    /// <summary>
    /// Where a figure is that obeys Walk, Drive and Halt, in the link's metres and radians. Advance it in each frame
    /// and put the figure there. Of one thread.
    /// </summary>
    public sealed class Walker
    {
        /// <summary>Seconds for which a Drive holds: a frame less than the 0.5 that it may.</summary>
        private const double Hold = 0.45;

        /// <summary>m/s^2.</summary>
        private const double Gain = 2.0;

        /// <summary>rad/s.</summary>
        private const double Turning = 3.0;

        /// <summary>m/s at which it comes to its last point.</summary>
        private const double Slowest = 0.1;

        /// <summary>Metres before a point with a direction at which the figure turns that way.</summary>
        private const double Aside = 0.4;

        /// <summary>Radians off its way at which it stands still to turn.</summary>
        private const double Sharp = 0.7;
        private const double Near = 0.0005;
        private const double Faced = 0.005;

        private readonly Action<string, int> _reached;
        private readonly Action<string, Status> _completed;
        private Walk _walk;
        private int _index;
        private double _speed;
        private Drive _drive;
        private double _driveLeft;

        /// <param name="x">Where it begins.</param>
        /// <param name="y">Where it begins.</param>
        /// <param name="th">Which way it faces.</param>
        /// <param name="reached">Called for each point that is reached, as LinkClient.Reached.</param>
        /// <param name="completed">Called when a walk is over, as LinkClient.Completed.</param>
        public Walker(double x, double y, double th, Action<string, int> reached, Action<string, Status> completed)
        {
            X = x;
            Y = y;
            Th = th;
            _reached = reached;
            _completed = completed;
        }

        public double X { get; private set; }

        public double Y { get; private set; }

        public double Th { get; private set; }

        /// <summary>Whether it is on its way somewhere, or driven.</summary>
        public bool IsMoving
        {
            get { return _walk != null || _driveLeft > 0; }
        }

        /// <summary>Whether the figure can be at x, y: asked where it is driven by hand. Null for everywhere.</summary>
        public Func<double, double, bool> CanStand { get; set; }

        public void Take(Walk walk)
        {
            Halt();
            _walk = walk;
            _index = 0;
            _speed = 0.0;
        }

        public void Take(Drive drive)
        {
            Halt();
            _drive = drive;
            _driveLeft = Hold;
        }

        /// <summary>A Halt has come.</summary>
        public void Halt()
        {
            Walk walk = _walk;
            Forget();
            if (walk != null)
            {
                _completed(walk.Id, Status.Abort);
            }
        }

        /// <summary>The adapter is disconnected: stand still, without an event.</summary>
        public void Forget()
        {
            _walk = null;
            _driveLeft = 0.0;
        }

        /// <summary>Go on for so many seconds.</summary>
        public void Advance(double seconds)
        {
            if (_walk != null)
            {
                GoOn(seconds);
            }
            else if (_driveLeft > 0)
            {
                Steer(Math.Min(seconds, _driveLeft));
                _driveLeft -= seconds;
            }
        }

        private void GoOn(double seconds)
        {
            double time = seconds;
            // A step that takes no time reaches a point, of which there are so many.
            while (time > 0 && _walk != null)
            {
                Waypoint goal = _walk.Path[_index];
                double distance = Math.Sqrt(Square(goal.X - X) + Square(goal.Y - Y));
                double off = goal.Th.HasValue ? Coordinates.Wrapped(goal.Th.Value - Th) : 0.0;
                if (distance > Near)
                {
                    time -= Go(goal, distance, time);
                }
                else if (Math.Abs(off) > Faced)
                {
                    time -= Face(off, time);
                }
                else
                {
                    Arrive();
                }
            }
        }

        private void Arrive()
        {
            Walk walk = _walk;
            int index = _index++;
            bool last = _index == walk.Path.Count;
            if (last)
            {
                _walk = null;
            }
            _reached(walk.Id, index);
            if (last)
            {
                _completed(walk.Id, Status.Ok);
            }
        }

        /// <summary>Go straight on, turning that way; the seconds it took.</summary>
        private double Go(Waypoint goal, double distance, double time)
        {
            double off = Coordinates.Wrapped(Math.Atan2(goal.Y - Y, goal.X - X) - Th);
            if (goal.Th.HasValue && distance < Aside)
            {
                off = Coordinates.Wrapped(goal.Th.Value - Th);
            }
            else if (Math.Abs(off) > Sharp)
            {
                _speed = 0.0;
                return Face(off, time);
            }
            _speed = Math.Min(_speed + Gain * time, _walk.Speed);
            if (_index == _walk.Path.Count - 1)
            {
                double braking = Math.Sqrt(2.0 * Gain * distance);
                _speed = Math.Min(_speed, Math.Max(Math.Min(Slowest, _walk.Speed), braking));
            }
            double taken = Math.Min(time, distance / _speed);
            double part = Math.Min(1.0, _speed * taken / distance);
            Face(off, taken);
            X += (goal.X - X) * part;
            Y += (goal.Y - Y) * part;
            return taken;
        }

        /// <summary>Turn by an angle as far as the time allows; the seconds it took.</summary>
        private double Face(double off, double time)
        {
            double turned = Math.Max(-Turning * time, Math.Min(Turning * time, off));
            Th = Coordinates.Wrapped(Th + turned);
            return Math.Abs(turned) / Turning;
        }

        private void Steer(double seconds)
        {
            Th = Coordinates.Wrapped(Th + _drive.Turn * seconds);
            double x = (_drive.Ahead * Math.Cos(Th) - _drive.Left * Math.Sin(Th)) * seconds;
            double y = (_drive.Ahead * Math.Sin(Th) + _drive.Left * Math.Cos(Th)) * seconds;
            // Along a wall rather than not at all.
            bool moved = Step(x, y) || Step(x, 0) || Step(0, y);
            _driveLeft = moved || _drive.Turn != 0 ? _driveLeft : 0.0;
        }

        private bool Step(double x, double y)
        {
            if (CanStand != null && !CanStand(X + x, Y + y))
            {
                return false;
            }
            X += x;
            Y += y;
            return true;
        }

        private static double Square(double value)
        {
            return value * value;
        }
    }
}
