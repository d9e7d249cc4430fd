// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Linq;

namespace OpenRoIS
{
    /// <summary>
    /// Conditions of components, the wire's subset of CQL2-Text. A gateway knows the properties <c>component_ref</c> and
    /// <c>component_type</c>, which is a URN.
    /// </summary>
    public static class Condition
    {
        /// <summary>It is this component.</summary>
        public static string ComponentRef(string componentRef)
        {
            return "component_ref = " + Quoted(componentRef);
        }

        /// <summary>It is of this type.</summary>
        public static string ComponentType(string urn)
        {
            return "component_type = " + Quoted(urn);
        }

        /// <summary>
        /// Its reference is like a pattern, in which <c>%</c> stands for any text and <c>_</c> for any character:
        /// <c>avatar/%</c>.
        /// </summary>
        public static string ComponentRefLike(string pattern)
        {
            return "component_ref LIKE " + Quoted(pattern);
        }

        /// <summary>All of these hold; empty ones always do.</summary>
        public static string And(params string[] conditions)
        {
            return string.Join(" AND ", conditions.Where(condition => !string.IsNullOrEmpty(condition)));
        }

        internal static string Quoted(string text)
        {
            if (text == null)
            {
                throw new ArgumentNullException("text");
            }
            return "'" + text.Replace("'", "''") + "'";
        }
    }
}
