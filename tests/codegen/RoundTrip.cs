// Reads every case of the corpus as its type and writes it again; says of each what came of it, one line of JSON each.
using System;
using System.Collections.Generic;
using System.IO;
using System.Text;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;
using OpenRoIS;

public static class RoundTrip
{
    public static void Main(string[] arguments)
    {
        TextWriter output = new StreamWriter(Console.OpenStandardOutput(), new UTF8Encoding(false));
        foreach (string path in Directory.GetFiles(arguments[0], "*.json"))
        {
            JObject file = Parse(File.ReadAllText(path));
            string name = (string)file["type"];
            Type type = TypeOf(name);
            foreach (string kind in new[] { "valid", "invalid" })
            {
                foreach (JToken one in (JArray)file[kind])
                {
                    JObject told = new JObject();
                    told["type"] = name;
                    told["name"] = one["name"];
                    told["valid"] = kind == "valid";
                    try
                    {
                        string message = one["message"].ToString(Formatting.None);
                        told["written"] = RoISJson.Write(RoISJson.Read(message, type));
                    }
                    catch (JsonException error)
                    {
                        told["refused"] = error.Message;
                    }
                    output.WriteLine(told.ToString(Formatting.None));
                }
            }
        }
        output.Flush();
    }

    private static JObject Parse(string text)
    {
        JsonTextReader reader = new JsonTextReader(new StringReader(text));
        reader.DateParseHandling = DateParseHandling.None;
        return JObject.Load(reader);
    }

    private static Type TypeOf(string name)
    {
        Type type = typeof(RoISJson).Assembly.GetType("OpenRoIS." + name);
        return type ?? typeof(RoISJson).Assembly.GetType("OpenRoIS.I" + name, true);
    }
}
