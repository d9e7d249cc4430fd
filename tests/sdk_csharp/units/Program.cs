// Tests of the SDK's parts, compiled with its sources: every public method of a class that is called ...Tests. Says of each
// what came of it, one line of JSON each.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Text;
using System.Threading.Tasks;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;

public static class Program
{
    private const int Patience = 30000;

    /// <summary>The file with the corpus of values.</summary>
    public static string ValuesFile { get; private set; }

    public static void Main(string[] arguments)
    {
        ValuesFile = arguments[0];
        TextWriter output = new StreamWriter(Console.OpenStandardOutput(), new UTF8Encoding(false));
        foreach (Type tests in Assembly.GetExecutingAssembly().GetTypes().Where(type => type.Name.EndsWith("Tests")))
        {
            foreach (MethodInfo test in tests.GetMethods(BindingFlags.Public | BindingFlags.Static | BindingFlags.DeclaredOnly))
            {
                var told = new JObject(
                    new JProperty("test", tests.Name + "." + test.Name), new JProperty("failure", Failure(test)));
                output.WriteLine(told.ToString(Formatting.None));
            }
        }
        output.Flush();
    }

    private static string Failure(MethodInfo test)
    {
        try
        {
            var running = test.Invoke(null, new object[0]) as Task;
            if (running != null && !running.Wait(Patience))
            {
                return "it does not end";
            }
            return null;
        }
        catch (Exception error)
        {
            return error.GetBaseException().ToString();
        }
    }
}

public static class Check
{
    public static void Equal<T>(T wanted, T found)
    {
        if (!EqualityComparer<T>.Default.Equals(wanted, found))
        {
            throw new Exception(JsonConvert.SerializeObject(found) + " is not " + JsonConvert.SerializeObject(wanted));
        }
    }

    public static void Equal<T>(IEnumerable<T> wanted, IEnumerable<T> found)
    {
        Equal(string.Join(", ", wanted), string.Join(", ", found));
    }

    public static void True(bool holds, string what)
    {
        if (!holds)
        {
            throw new Exception("it does not hold: " + what);
        }
    }

    public static T Throws<T>(Action work) where T : Exception
    {
        try
        {
            work();
        }
        catch (T error)
        {
            return error;
        }
        throw new Exception("no " + typeof(T).Name);
    }

    public static async Task<T> ThrowsAsync<T>(Func<Task> work) where T : Exception
    {
        try
        {
            await work();
        }
        catch (T error)
        {
            return error;
        }
        throw new Exception("no " + typeof(T).Name);
    }
}
