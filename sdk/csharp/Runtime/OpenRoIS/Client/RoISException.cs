// Copyright the OpenRoIS authors. Apache-2.0.
using System;

namespace OpenRoIS
{
    /// <summary>
    /// An operation, or a command, has not ended well: the return code (RoIS 2.0, table 8.1) or the status says how,
    /// and so does the type.
    /// </summary>
    public class RoISException : Exception
    {
        protected internal RoISException(string message, string reason = "")
            : base(message)
        {
            Reason = reason;
        }

        /// <summary>
        /// Why, in a sentence of the gateway or the component; empty where the gateway speaks the base wire alone.
        /// </summary>
        public string Reason { get; private set; }

        internal static RoISException Of(ReturnCode code, string message, string reason)
        {
            switch (code)
            {
                case ReturnCode.BadParameter:
                    return new BadParameterException(message, reason);
                case ReturnCode.Unsupported:
                    return new UnsupportedException(message, reason);
                case ReturnCode.OutOfResources:
                    return new OutOfResourcesException(message, reason);
                case ReturnCode.Timeout:
                    return new TimedOutException(message, reason);
                default:
                    return new ComponentFailedException(message, reason);
            }
        }

        internal static RoISException Of(CompletedStatus status, string message, string reason)
        {
            switch (status)
            {
                case CompletedStatus.Abort:
                    return new AbortedException(message, reason);
                case CompletedStatus.OutOfResources:
                    return new OutOfResourcesException(message, reason);
                case CompletedStatus.Timeout:
                    return new TimedOutException(message, reason);
                default:
                    return new ComponentFailedException(message, reason);
            }
        }
    }

    /// <summary>BAD_PARAMETER: something that was said does not fit.</summary>
    public sealed class BadParameterException : RoISException
    {
        internal BadParameterException(string message, string reason = "")
            : base(message, reason)
        {
        }
    }

    /// <summary>UNSUPPORTED: there is no such component, message or stream, or it is not for this application.</summary>
    public sealed class UnsupportedException : RoISException
    {
        internal UnsupportedException(string message, string reason = "")
            : base(message, reason)
        {
        }
    }

    /// <summary>OUT_OF_RESOURCES: another application has it, it was not bound, or there is too much of something.</summary>
    public sealed class OutOfResourcesException : RoISException
    {
        internal OutOfResourcesException(string message, string reason = "")
            : base(message, reason)
        {
        }
    }

    /// <summary>TIMEOUT: the component took longer than it may.</summary>
    public sealed class TimedOutException : RoISException
    {
        internal TimedOutException(string message, string reason = "")
            : base(message, reason)
        {
        }
    }

    /// <summary>ERROR: the component, or its engine, has failed.</summary>
    public sealed class ComponentFailedException : RoISException
    {
        internal ComponentFailedException(string message, string reason = "")
            : base(message, reason)
        {
        }
    }

    /// <summary>ABORT: the command was stopped, or one before it in its sequence has failed.</summary>
    public sealed class AbortedException : RoISException
    {
        internal AbortedException(string message, string reason = "")
            : base(message, reason)
        {
        }
    }
}
