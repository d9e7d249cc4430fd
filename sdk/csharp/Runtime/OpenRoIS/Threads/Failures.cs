// Copyright the OpenRoIS authors. Apache-2.0.
using System;

namespace OpenRoIS
{
    /// <summary>Reports what a program's own code has thrown.</summary>
    internal static class Failures
    {
        /// <summary>Calls a handler of failures; one that fails itself ends nothing, and standard error has both.</summary>
        internal static void Report(Action<Exception> failed, Exception error)
        {
            try
            {
                failed(error);
            }
            catch (Exception another)
            {
                Console.Error.WriteLine("OpenRoIS: " + error + "\nThe handler of failures has failed: " + another);
            }
        }
    }
}
