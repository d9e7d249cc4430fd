using System;

namespace OpenRoIS.Link
{
    /// <summary>
    /// The adapter broke the protocol, refused us or is gone, or what shall be sent does not fit the link.
    /// </summary>
    public sealed class LinkException : Exception
    {
        public LinkException(string message) : base(message)
        {
        }

        public LinkException(string message, Exception cause) : base(message, cause)
        {
        }
    }
}
