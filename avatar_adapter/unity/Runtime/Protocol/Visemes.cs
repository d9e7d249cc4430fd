using System;
using System.Collections.Generic;

namespace OpenRoIS.Link
{
    /// <summary>The fifteen mouth shapes of the Oculus lip-sync set, as the link names them.</summary>
    public static class Visemes
    {
        public static readonly IList<string> Names = Array.AsReadOnly(new[]
        {
            "sil", "PP", "FF", "TH", "DD", "kk", "CH", "SS", "nn", "RR", "aa", "E", "ih", "oh", "ou"
        });

        /// <summary>The place of aa, the most open one.</summary>
        public const int Open = 10;

        internal static int IndexOf(string name)
        {
            return Names.IndexOf(name);
        }
    }
}
